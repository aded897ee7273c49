"""The solid in two parts joined at a section: a foot that is kept, and the rest."""
