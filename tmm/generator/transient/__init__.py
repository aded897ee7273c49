"""The machine in time: steps that keep the energy balance, to a stated error."""
