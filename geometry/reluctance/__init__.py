"""The normal actuator divided: half section, swept sector, tetrahedra; TEAM problem 20."""
