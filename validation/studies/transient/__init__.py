"""The generator in time: waveforms, a run, its phases, its file and its picture."""
