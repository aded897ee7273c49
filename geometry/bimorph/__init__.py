"""The lateral actuator divided: a row of pieces, bricks of high order, tetrahedra."""
