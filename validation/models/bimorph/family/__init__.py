"""Many bimorphs of the model solid at once: reduced bases, what is read off them, derivatives."""
