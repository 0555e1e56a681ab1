"""Did anything get lost? Two models compared in structure, topology, mass, geometry and pictures."""
