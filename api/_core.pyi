# Made by nanobind.stubgen from core/bind; not to be edited.
# ruff: noqa: E501, I001
"""Native core of trimray. Lengths are mm, angles radians."""

from collections.abc import Sequence
import enum
from typing import Annotated, Any

import numpy
from numpy.typing import NDArray

class CoreError(RuntimeError):
    pass

class FormatError(CoreError):
    pass

class ArgumentError(CoreError):
    pass

class Store:
    """Every face of a model as an exact trimmed NURBS surface; immutable."""

    @staticmethod
    def build(
        brep: bytes,
        prototype_shapes: Annotated[
            NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        prototype_colors: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)
        ],
        face_color_shapes: Annotated[
            NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        face_colors: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)
        ],
        instance_prototypes: Annotated[
            NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        instance_placements: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 12), order="C", device="cpu", writable=False)
        ],
        instance_colors: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)
        ],
        meta: str,
    ) -> Store:
        """
        From the importer's byte stream and arrays. FormatError: the stream is damaged; ArgumentError: the arrays do not fit it.
        """

    @staticmethod
    def from_triangles(
        vertices: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        triangles: Annotated[
            NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        group_ends: Annotated[
            NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        colors: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)
        ],
        meta: str,
    ) -> Store:
        """
        A model that comes as triangles: vertices (n, 3) float64, mm; triangles (m, 3) int32, counter-clockwise from outside; group_ends (g,) int32: each group of triangles, up to its end, is one face; colors (g, 4) float32, sRGB-encoded, red -1 for none. ArgumentError: an index that names nothing, a coordinate that is not finite, groups that are empty or do not cover the triangles.
        """

    @staticmethod
    def merge(stores: Sequence[Store], meta: str) -> Store:
        """
        All prototypes, instances and faces of the first store, then those of the second, and so on. ArgumentError: too large together.
        """

    @staticmethod
    def load(data: bytes) -> Store:
        """From what save() gave. FormatError: anything else."""

    def save(self) -> bytes:
        """The store as the bytes of one file."""

    @property
    def meta(self) -> str:
        """The importer's JSON."""

    @property
    def face_count(self) -> int: ...
    def face_kinds(self) -> list[str]:
        """Surface kind of every face."""

    def face_statuses(self) -> list[str]:
        """ "ok" or the reason the face cannot be drawn."""

    def face_colors(self) -> NDArray[numpy.float32]:
        """
        (n, 4) float32, sRGB-encoded, straight alpha; red -1 where the face has none of its own.
        """

    def face_prototypes(self) -> NDArray[numpy.int32]:
        """(n,) int32."""

    def face_shapes(self) -> NDArray[numpy.int32]:
        """(n,) int32, 1-based position in the importer's byte stream."""

    def instance_prototypes(self) -> NDArray[numpy.int32]:
        """(n,) int32."""

    def instance_placements(self) -> NDArray[numpy.float64]:
        """(n, 3, 4) float64, prototype to world, mm."""

    def instance_colors(self) -> NDArray[numpy.float32]:
        """
        (n, 4) float32, sRGB-encoded: of faces without a colour of their own; red -1 where there is none.
        """

    def prototype_faces(self) -> NDArray[numpy.int32]:
        """(n, 2) int32: first face and one past the last."""

    def prototype_shells(self) -> NDArray[numpy.int32]:
        """(n, 2) int32: closed and open shells."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """
        Every array of the store by its name in core/nurbs/store.h, read-only, sharing the store's memory: knots (n,), ctrl_h (n, 4), trim_ctrl_h (n, 3), edge_ctrl_h (n, 4), mesh_vertices (n, 3) float64; edge_coedges (n,), mesh_triangles (n, 3) int32; surfaces, conics, faces, loops, coedges, trim_pieces, edges, edge_pieces, vertices, shells, prototypes, instances: structured, (n,). A range is (2,) int32, an enum uint8, a box (2, d) and a vector (3,) float64, a colour (4,) float32; placement (4, 3): the columns.
        """

    def parity_targets(self) -> tuple[NDArray[numpy.float64], int, int]:
        """
        Points (n, 3) float64, world, mm, on every vertex and edge; closed shells; open shells, over all instances.
        """

    def extent(self, threads: int = 0) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        Tight bounds (2, 3) float64 and outline points (n, 3) float64, world, mm; inf, -inf when nothing can be drawn.
        """

class UpAxis(enum.Enum):
    X = 0

    Y = 1

    Z = 2

    MINUS_X = 3

    MINUS_Y = 4

    MINUS_Z = 5

class Camera:
    """Where the rays of a picture start and go."""

    @staticmethod
    def fit(
        azimuth_deg: float,
        elevation_deg: float,
        up: UpAxis,
        points: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        width_px: int,
        height_px: int,
        perspective: bool,
        fov_deg: float,
        margin: float,
    ) -> Camera:
        """Fitted to points (n, 3) float64, mm."""

    @property
    def eye(self) -> NDArray[numpy.float64]:
        """(3,) float64, mm."""

    @property
    def right(self) -> NDArray[numpy.float64]:
        """(3,) float64, unit."""

    @property
    def up(self) -> NDArray[numpy.float64]:
        """(3,) float64, unit."""

    @property
    def forward(self) -> NDArray[numpy.float64]:
        """(3,) float64, unit."""

    @property
    def perspective(self) -> bool: ...
    @property
    def pixel(self) -> float:
        """mm per px (orthographic) or tangent per px (perspective)."""

    @property
    def width_px(self) -> int: ...
    @property
    def height_px(self) -> int: ...
    def zoomed(self, zoom: float) -> Camera:
        """The same picture enlarged about its centre."""

    def turned(
        self,
        angle_deg: float,
        pivot: Annotated[
            NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        up: UpAxis,
    ) -> Camera:
        """
        Moved about the upright line through pivot (3,) float64, mm, so that the azimuth grows.
        """

    def rays(self) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        Origins and unit directions, (height * width, 3) float64 each, of the pixel centres.
        """

class Seeds:
    """
    Where on which surface a tracer should look first, by pixel. Never trusted.
    """

    @staticmethod
    def from_arrays(
        id: Annotated[
            NDArray[numpy.uint32], dict(shape=(None, None), order="C", device="cpu", writable=False)
        ],
        uv: Annotated[
            NDArray[numpy.float32], dict(shape=(None, None, 2), order="C", device="cpu", writable=False)
        ],
        targets: Annotated[
            NDArray[numpy.int32], dict(shape=(None, 2), order="C", device="cpu", writable=False)
        ],
        target_uv: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 2), order="C", device="cpu", writable=False)
        ],
    ) -> Seeds:
        """
        id (h, w) uint32: 0 for nothing, else one more than the number of a target. uv (h, w, 2) float32, as fractions of the face's uv box, for targets that are surfaces; (0, 0, 2) for targets that are triangles. targets (n, 2) int32: instance and face; target_uv (n, 2) float32.
        """

    @property
    def targets(self) -> int: ...
    def id(self) -> NDArray[numpy.uint32]:
        """(h, w) uint32."""

    def uv(self) -> NDArray[numpy.float32]:
        """(h, w, 2) float32, of what was seen; 0 for nothing."""

def choose_raster(covered_px: float, triangles: int) -> str:
    """The backend that gives seeds soonest. CoreError: none is available."""

class Progress:
    """Tiles done of a render that another thread waits for."""

    def __init__(self) -> None: ...
    @property
    def done(self) -> int: ...
    @property
    def total(self) -> int: ...
    @property
    def cancelled(self) -> bool: ...
    def cancel(self) -> None: ...

class SecondaryOptions:
    """Rays that go on from what a picture shows."""

    def __init__(self) -> None: ...
    @property
    def shadows(self) -> bool: ...
    @shadows.setter
    def shadows(self, arg: bool, /) -> None: ...
    @property
    def ambient_occlusion(self) -> int:
        """Rays a sample."""

    @ambient_occlusion.setter
    def ambient_occlusion(self, arg: int, /) -> None: ...
    @property
    def occlusion_distance(self) -> float:
        """mm."""

    @occlusion_distance.setter
    def occlusion_distance(self, arg: float, /) -> None: ...
    @property
    def reflections(self) -> int:
        """Bounces."""

    @reflections.setter
    def reflections(self, arg: int, /) -> None: ...
    @property
    def diagonal(self) -> float:
        """mm, of the model's bounds."""

    @diagonal.setter
    def diagonal(self, arg: float, /) -> None: ...

class Scene:
    """A store made ready for rays."""

    def __init__(self, store: Store, threads: int = 0) -> None: ...
    @property
    def bytes(self) -> int: ...
    @property
    def leaf_boxes(self) -> int: ...
    @property
    def build_seconds(self) -> float: ...
    def cast(
        self,
        org: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        dir: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        tmin: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        tmax: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        reference: bool = False,
        threads: int = 0,
    ) -> tuple[
        NDArray[numpy.float64],
        NDArray[numpy.int32],
        NDArray[numpy.int32],
        NDArray[numpy.float64],
        NDArray[numpy.float64],
    ]:
        """
        Nearest hits: t (n,), face (n,), instance (n,), uv (n, 2), normal (n, 3).
        """

    def count_hits(
        self,
        org: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        dir: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        tmin: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        tmax: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        reference: bool = False,
        threads: int = 0,
    ) -> NDArray[numpy.int32]:
        """Crossings per ray, (n,) int32."""

    def render(
        self,
        camera: Camera,
        aovs: Sequence[str],
        samples: int,
        background: Annotated[
            NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)
        ],
        orientation: bool,
        mode: str,
        threads: int,
        progress: Progress,
        seeds: Seeds | None = None,
        secondary: SecondaryOptions = ...,
    ) -> dict[str, Any]:
        """
        mode: hybrid, standard or reference; seeds: of the same camera, for hybrid. Planes of a picture by name, each (height, width[, channels]).
        """

def near_edge(scene: Scene, org: Sequence[float], dir: Sequence[float], tmax: float) -> bool:
    """Does the ray pass an edge within its band before tmax (mm)?"""

def measure_cast(
    scene: Scene,
    org: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)],
    dir: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)],
    threads: int = 0,
) -> dict[str, Any]:
    """
    Seconds of casting alone, without any copying, and the counters of the call.
    """

def edge_points(store: Store, per_edge: int = 2) -> NDArray[numpy.float64]:
    """
    (n, 3) float64, mm, world: every vertex, and per_edge points of every edge, of every instance; of mesh faces, a corner and a point on a side of every triangle.
    """

def paper_scene(store: Store, packet: int = 4, threads: int = 0) -> Scene:
    """
    A scene as the paper has it: many small boxes, rays in packets of so many (1 to 64). The same hits.
    """

def measure_picture(
    scene: Scene, camera: Camera, mode: str, seeds: Seeds | None = None, tile: int = 32, threads: int = 0
) -> dict[str, Any]:
    """
    Time of the nearest hits of one ray a pixel, in seconds and in processor seconds of all threads, and counters. mode: hybrid or standard. solves: calls of an intersector, a ray and a surface or box each.
    """

def tessellate(
    store: Store, prototype: int, deviation: float, angle: float, threads: int = 0
) -> tuple[
    tuple[
        NDArray[numpy.float64],
        NDArray[numpy.int32],
        NDArray[numpy.float64],
        NDArray[numpy.int32],
        NDArray[numpy.float64],
    ],
    list[tuple[int, str]],
]:
    """
    Watertight mesh of a prototype, deviation in mm (inf: the model's turns alone), angle in rad (inf: none): (vertices (n, 3), triangles (m, 3), corner_uv (m, 3, 2), face (m,), deviation (m,)) and [(face, why nothing is proven)].
    """

class MeshLevels:
    """Meshes of a store for cameras, kept from one to the next."""

    def __init__(self, store: Store, angle: float) -> None:
        """angle: rad, inf for none."""

    def meshes(
        self, camera: Camera, deviation_px: float, threads: int = 0
    ) -> tuple[
        list[tuple[int, int, bool]],
        list[
            tuple[
                tuple[
                    NDArray[numpy.float64],
                    NDArray[numpy.int32],
                    NDArray[numpy.float64],
                    NDArray[numpy.int32],
                    NDArray[numpy.float64],
                ],
                list[tuple[int, str]],
            ]
        ],
        tuple[int, int],
    ]:
        """
        [(instance, mesh, cut)] of the instances in the picture; by mesh what tessellate() returns; (meshes built, meshes reused).
        """

    def triangles(self, camera: Camera, deviation_px: float, threads: int = 0) -> tuple[int, int, int]:
        """
        The same, as counts: triangles of all instances, meshes built, meshes reused.
        """

    @property
    def bytes(self) -> int:
        """Of the meshes that are kept."""

class Rasterizer:
    """Draws the meshes of a view once; what each pixel saw."""

    def __init__(self, backend: str) -> None:
        """
        backend: osmesa, egl or embree. CoreError with the reason where it is not available.
        """

    @property
    def name(self) -> str: ...
    def seeds(
        self,
        levels: MeshLevels,
        store: Store,
        camera: Camera,
        deviation_px: float = 0.3,
        process: str = "uv",
        threads: int = 0,
    ) -> Seeds:
        """What draw() tells, as the tracer takes it, without a copy."""

    def draw(
        self,
        levels: MeshLevels,
        store: Store,
        camera: Camera,
        deviation_px: float = 0.3,
        process: str = "uv",
        threads: int = 0,
    ) -> tuple[NDArray[numpy.uint32], NDArray[numpy.float32], NDArray[numpy.int32], NDArray[numpy.int32]]:
        """
        id (h, w) uint32, 0 where nothing is seen; uv (h, w, 2) float32, fractions of the face's uv box, NaN where nothing is seen; and by id - 1 instance (n,) and face (n,). levels: of this store. process: id (one a triangle, uv the mean of its corners) or uv (one a surface, uv as interpolated).
        """

    def warm_up(self) -> None:
        """Does now what the first draw would spend on loading and compiling."""

def raster_backends() -> list[tuple[str, bool, str]]:
    """[(name, whether it is available, its version or why not)]."""

class MeshFile:
    """What read_mesh_file() found."""

    def vertices(self) -> NDArray[numpy.float64]:
        """(n, 3) float64, as they stand in the file; taken as mm."""

    def triangles(self) -> NDArray[numpy.int32]:
        """(m, 3) int32."""

    def group_ends(self) -> NDArray[numpy.int32]:
        """(g,) int32: one past the last triangle of each group."""

    def group_colors(self) -> NDArray[numpy.float32]:
        """(g, 4) float32, sRGB-encoded; red -1 where there is none."""

    def group_names(self) -> list[bytes]:
        """Bytes as in the file, by group; often empty."""

    @property
    def faces(self) -> int:
        """Polygons in the file."""

    @property
    def left_out(self) -> int:
        """Of them, those without three different corners."""

    @property
    def mixed_colors(self) -> bool:
        """More colours than groups are worth: the groups have their mean."""

    @property
    def binary(self) -> bool:
        """Not a text."""

def read_mesh_file(path: str, format: str) -> MeshFile:
    """
    A file of triangles; format: stl, obj, ply or off. FormatError: damaged, or no such file.
    """

def write_mesh_file(
    format: str,
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    normals: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    colors: Annotated[NDArray[numpy.float32], dict(shape=(None, 4), order="C", device="cpu", writable=False)],
) -> bytes:
    """
    The bytes of a stl, obj, ply or off file. normals: by vertex, (0, 3) for none; colors: by triangle, (0, 4) for none. Equal arguments give equal bytes. ArgumentError: the arrays do not fit.
    """

def corner_normals(
    store: Store,
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    corner_uv: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3, 2), order="C", device="cpu", writable=False)
    ],
    face: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    threads: int = 0,
) -> NDArray[numpy.float64]:
    """
    Outward unit normals of the exact surfaces at the corners of triangles, (m, 3, 3) float64. ArgumentError: the arrays do not fit.
    """

def check_mesh(
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
) -> dict[str, Any]:
    """
    Open and non-manifold edges, non-manifold vertices, degenerate triangles, volume (mm^3) and area (mm^2) of the mesh. ArgumentError: a triangle names a vertex that does not exist.
    """

def measure_mesh(
    store: Store,
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    corner_uv: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3, 2), order="C", device="cpu", writable=False)
    ],
    face: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    enough: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    subdivisions: int = 6,
    most_triangles: int = 0,
    seed: int = 1,
    threads: int = 0,
) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
    """
    By triangle, mm: the largest distance found of its points from its face's surface, and of the surface's points at the same uv from the face's triangles (other triangles than its own are asked where that is over enough, (m,)); NaN where not chosen or not exact. ArgumentError: the mesh does not fit the store.
    """

def measure_mesh_edges(
    store: Store,
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    corner_uv: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3, 2), order="C", device="cpu", writable=False)
    ],
    face: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
    points: int = 16,
    threads: int = 0,
) -> dict[str, Any]:
    """
    Every side of a triangle where its face ends: triangle, corner, edge (-1: on none), open, from and to on the edge, distances (mm); and by edge, mm, its length in use and how much of it the mesh lacks.
    """

def measure_mesh_cover(
    store: Store,
    vertices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    triangles: Annotated[
        NDArray[numpy.int32], dict(shape=(None, 3), order="C", device="cpu", writable=False)
    ],
    corner_uv: Annotated[
        NDArray[numpy.float64], dict(shape=(None, 3, 2), order="C", device="cpu", writable=False)
    ],
    face: Annotated[NDArray[numpy.int32], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> dict[str, Any]:
    """
    By face of the store: signed area of its triangles in uv, their number, and how many are turned over in uv.
    """

def closed_faces(store: Store) -> NDArray[numpy.uint8]:
    """
    (n,) uint8: 1 for faces of closed shells all of whose faces can be drawn.
    """

def edge_uses(store: Store) -> NDArray[numpy.int32]:
    """(n,) int32: how often each edge is used by faces that can be drawn."""

class PointIndex:
    """A store made ready for distances."""

    def __init__(self, store: Store, threads: int = 0) -> None: ...
    @property
    def diagonal(self) -> float:
        """Of the box of all that is indexed, mm."""

    @property
    def left_out(self) -> NDArray[numpy.int32]:
        """(k,) int32: faces that are not, or not wholly, indexed."""

    @property
    def bytes(self) -> int: ...
    def nearest(
        self,
        points: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        edges: bool = False,
        threads: int = 0,
    ) -> tuple[
        NDArray[numpy.float64],
        NDArray[numpy.float64],
        NDArray[numpy.int32],
        NDArray[numpy.int32],
        NDArray[numpy.int32],
        NDArray[numpy.float64],
        NDArray[numpy.float64],
        NDArray[numpy.float64],
    ]:
        """
        distance (n,), point (n, 3), face (n,), instance (n,), edge (n,), uv (n, 2), band (n,), gap (n,); edges: of the edges alone.
        """

def sample_faces(
    store: Store, count: int, seed: int, threads: int = 0
) -> tuple[
    NDArray[numpy.float64],
    NDArray[numpy.float64],
    NDArray[numpy.int32],
    NDArray[numpy.int32],
    NDArray[numpy.float64],
]:
    """
    count points of each face of each instance: point (n, 3), normal (n, 3), face (n,), instance (n,), uv (n, 2).
    """

def sample_edges(
    store: Store, count: int, seed: int, threads: int = 0
) -> tuple[NDArray[numpy.float64], NDArray[numpy.int32], NDArray[numpy.int32]]:
    """
    count points of each edge of each instance: point (n, 3), edge (n,), instance (n,).
    """

def measure_mass(store: Store, threads: int = 0) -> dict[str, Any]:
    """
    area, volume, each with its error; centroid, inertia about it, centroid_error, inertia_error; shell_volumes, in their prototypes, with their errors; face_integrals, face_integral_errors (n, 11), in their prototypes, NaN for faces that cannot be drawn, about origins (p, 3): area; by the divergence theorem volume, x, y, z, xx, xy, xz, yy, yz, zz; left_out: faces without an area.
    """
