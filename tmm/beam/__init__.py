"""The lateral actuator as a row of beams: closed forms, modes, derivatives."""
