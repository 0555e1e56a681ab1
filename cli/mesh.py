"""trimray mesh: each input, or all of them together, to a file of triangles."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING, Any

from trimray.tri_mesh import parse_deviation

from .files import MESH, Job, plan
from .jobs import run_jobs, tell_problems, write
from .output import say
from .progress import Sink

if TYPE_CHECKING:
    from trimray import Model, TriMesh


def run(inputs: tuple[str, ...], **options: Any) -> int:
    """Returns the exit code. options: of the table, by name."""
    jobs = plan(inputs, options["output"], options["mesh_format"], MESH)

    def make(model: Model, job: Job, progress: Sink, start: float) -> int:
        angle, camera = options["angle"], None
        if parse_deviation(options["deviation"])[1] == "px":
            camera = model.camera(
                options["size"], view=options["view"], projection=options["projection"], up=options["up"]
            )
        mesh = model.tessellate(
            options["deviation"],
            angle=None if angle is None else math.radians(angle),
            view=camera,
            threads=options["jobs"],
            progress=progress,
        )
        progress("write", None)
        data = io.BytesIO()
        mesh.save(data, format=job.format)
        write(job.target, data.getvalue())
        if options["verbose"]:
            say(_summary(job.name, mesh))
        tell_problems(job.name, _problems(model, mesh), "TriMesh.issues")
        return 1 if mesh.issues else 0

    return run_jobs(jobs, options, make, what="mesh")


def _problems(model: Model, mesh: TriMesh) -> list[str]:
    return [
        f"{model.faces[issue.face].call()}: its deviation is not proven: {issue.reason}"
        for issue in mesh.issues
    ]


def _summary(name: str, mesh: TriMesh) -> str:
    check = mesh.check()
    asked = f"{mesh.asked:.3g} mm" if mesh.asked_px is None else f"{mesh.asked_px:g} px"
    proven = mesh.deviation[mesh.deviation < math.inf]
    worst = float(proven.max()) if len(proven) else 0.0
    return (
        f"{name}: {len(mesh.triangles)} triangles, {len(mesh.vertices)} vertices, within {worst:.3g} mm "
        f"({asked} asked); {check.open_edges} open and {check.non_manifold_edges} non-manifold "
        f"edges, {check.degenerate_triangles} degenerate triangles"
    )
