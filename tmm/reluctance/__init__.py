"""The normal actuator as a network of reluctances, and when its rod moves."""
