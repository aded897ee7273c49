"""What the paper says of the normal actuator: sections 2.2 and 5.1, and Fig 3's set-up."""

from __future__ import annotations

#: Outer diameter, working gap and height of both actuators together (m).
OUTER_DIAMETER, GAP, TOTAL_HEIGHT = 2.3e-3, 0.2e-3, 41e-3
#: Force that the spring can put on the finger (N), and so what the pull must overcome.
FORCE = 0.11
#: Currents (A): about what pulls the rod down, what holds it, what drove it in Fig 16.
PULL_IN, HELD, DRIVEN = 0.13, 0.05, 0.12
