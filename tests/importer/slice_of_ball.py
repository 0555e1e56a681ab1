"""STEP text of a slice of a ball, as systems write it that give edges in space alone."""

import math

_HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
#1=APPLICATION_CONTEXT('');
#2=PRODUCT_CONTEXT('',#1,'mechanical');
#3=PRODUCT('slice','slice','',(#2));
#4=PRODUCT_DEFINITION_FORMATION('','',#3);
#5=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'');
#6=PRODUCT_DEFINITION('','',#4,#5);
#7=PRODUCT_DEFINITION_SHAPE('','',#6);
#8=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#9=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#10=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
#11=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),#8,'distance_accuracy_value','');
#12=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#11))
GLOBAL_UNIT_ASSIGNED_CONTEXT((#8,#9,#10))REPRESENTATION_CONTEXT('',''));
"""
_TAIL = """#13=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#{solid}),#12);
#14=SHAPE_DEFINITION_REPRESENTATION(#7,#13);
ENDSEC;
END-ISO-10303-21;
"""

Vector = tuple[float, float, float]
Loop = list[tuple[int, bool]]


class SliceOfBall:
    """What lies between two half planes through the poles, without what a flat cuts off its second edge.

    start, width: longitudes in degrees of the first half plane, and from there to the second. seam: the
    sphere's. flat: latitude up to which the flat goes, or None. first: the edge of the sphere's loop that the
    file names first. inward: every face is written with its normal into the ball.
    """

    def __init__(
        self, start: float, width: float, *, seam: float, flat: float | None, first: int, inward: bool
    ) -> None:
        self._records: list[str] = []
        self._vertices: dict[Vector, int] = {}
        self.radius, self._inward = 10.0, inward
        south, north = (0.0, 0.0, -self.radius), (0.0, 0.0, self.radius)
        axis = self._line(south, north)
        (out, right), (end, left) = (_axes(math.radians(u)) for u in (start, start + width))
        behind = _minus(right)
        begin = self._arc((0.0, 0.0, 0.0), behind, out, self.radius, south, north)
        faces = [([(begin, True), (axis, False)], self._plane((0.0, 0.0, 0.0), behind))]
        edges = flat_edges = [self._arc((0.0, 0.0, 0.0), _minus(left), end, self.radius, south, north)]
        if flat is not None:
            v = math.radians(flat)
            middle = _times(end, self.radius * math.cos(v))
            low, high = ((middle[0], middle[1], s * self.radius * math.sin(v)) for s in (-1.0, 1.0))
            below = self._arc((0.0, 0.0, 0.0), _minus(left), end, self.radius, south, low)
            above = self._arc((0.0, 0.0, 0.0), _minus(left), end, self.radius, high, north)
            # From below to above through the slice: about the flat's normal, turned over.
            bow = self._arc(middle, _minus(end), _minus(left), self.radius * math.sin(v), low, high)
            chord = self._line(low, high)
            edges, flat_edges = [below, bow, above], [below, chord, above]
            faces.append(([(chord, True), (bow, False)], self._plane(middle, end)))
        faces.append(
            ([(axis, True), *((e, False) for e in reversed(flat_edges))], self._plane((0.0, 0.0, 0.0), left))
        )
        lune = [*((e, True) for e in edges), (begin, False)]
        frame = self._frame((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), _axes(math.radians(seam))[0])
        ball = self._add(f"SPHERICAL_SURFACE('',#{frame},{self.radius})")
        faces.append((lune[first:] + lune[:first], ball))
        members = ",".join(f"#{self._face(loop, surface)}" for loop, surface in faces)
        shell = self._add(f"CLOSED_SHELL('',({members}))")
        solid = self._add(f"MANIFOLD_SOLID_BREP('',#{shell})")
        self.text = _HEAD + "".join(self._records) + _TAIL.format(solid=solid)
        cap = self.radius * (1.0 - math.cos(math.radians(flat or 0.0)))
        turn = math.radians(width)
        self.area_on_ball = 2.0 * turn * self.radius**2 - math.pi * self.radius * cap
        self.volume = 2.0 / 3.0 * turn * self.radius**3 - math.pi / 6.0 * cap**2 * (3.0 * self.radius - cap)

    def _add(self, record: str) -> int:
        self._records.append(f"#{101 + len(self._records)}={record};\n")
        return 100 + len(self._records)

    def _triple(self, kind: str, values: Vector) -> int:
        return self._add(f"{kind}('',({','.join(f'{value:.15f}' for value in values)}))")

    def _frame(self, centre: Vector, z: Vector, x: Vector) -> int:
        point = self._triple("CARTESIAN_POINT", centre)
        axes = [self._triple("DIRECTION", d) for d in (z, x)]
        return self._add(f"AXIS2_PLACEMENT_3D('',#{point},#{axes[0]},#{axes[1]})")

    def _plane(self, point: Vector, normal: Vector) -> int:
        return self._add(f"PLANE('',#{self._frame(point, normal, (0.0, 0.0, 1.0))})")

    def _vertex(self, point: Vector) -> int:
        key = (round(point[0], 9), round(point[1], 9), round(point[2], 9))
        if key not in self._vertices:
            self._vertices[key] = self._add(f"VERTEX_POINT('',#{self._triple('CARTESIAN_POINT', point)})")
        return self._vertices[key]

    def _arc(self, centre: Vector, z: Vector, x: Vector, radius: float, start: Vector, end: Vector) -> int:
        circle = self._add(f"CIRCLE('',#{self._frame(centre, z, x)},{radius:.15f})")
        return self._add(f"EDGE_CURVE('',#{self._vertex(start)},#{self._vertex(end)},#{circle},.T.)")

    def _line(self, start: Vector, end: Vector) -> int:
        way = self._add(f"VECTOR('',#{self._triple('DIRECTION', (0.0, 0.0, 1.0))},1.)")
        line = self._add(f"LINE('',#{self._triple('CARTESIAN_POINT', start)},#{way})")
        return self._add(f"EDGE_CURVE('',#{self._vertex(start)},#{self._vertex(end)},#{line},.T.)")

    def _face(self, loop: Loop, surface: int) -> int:
        if self._inward:
            loop = [(edge, not forward) for edge, forward in reversed(loop)]
        uses = [self._add(f"ORIENTED_EDGE('',*,*,#{e},.{'T' if forward else 'F'}.)") for e, forward in loop]
        edges = self._add(f"EDGE_LOOP('',({','.join(f'#{use}' for use in uses)}))")
        bound = self._add(f"FACE_OUTER_BOUND('',#{edges},.T.)")
        return self._add(f"ADVANCED_FACE('',(#{bound}),#{surface},.{'F' if self._inward else 'T'}.)")


def _axes(longitude: float) -> tuple[Vector, Vector]:
    """Outwards and eastwards at the equator."""
    x, y = math.cos(longitude), math.sin(longitude)
    return (x, y, 0.0), (-y, x, 0.0)


def _times(vector: Vector, factor: float) -> Vector:
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def _minus(vector: Vector) -> Vector:
    return _times(vector, -1.0)
