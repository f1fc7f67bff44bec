"""What the page shows of the body: its surface, its steps and fields, packed to fit."""

import dataclasses

import numpy as np

import fields
import surface
from report_page.packing import Pack

MOST_INVERTED = 2000  # cells whose edges are drawn, in one step


@dataclasses.dataclass
class Plan:
    """How much of it all goes into the page."""
    steps: list  # numbers of the steps
    all_columns: bool = True  # of vectors and tensors; otherwise their magnitude only
    triangles: int = None  # at most; None: as many as there are


class Body:
    """A file's steps, made ready for the viewer. `notes`: sentences on what was left out."""

    def __init__(self, steps, units, most_bytes, region_names=(), obstacles=None):
        self._all, self._units, self._region_names = steps, units, region_names
        self._obstacles = obstacles
        last = steps[-1]
        self._points, self._cells = last.points, last.cells
        self._regions = (last.cell_fields["region"].round().astype(int)
                         if "region" in last.cell_fields else None)
        several = self._regions is not None and len(np.unique(self._regions)) > 1
        self._surface = surface.Surface(self._points, self._cells, self._regions if several else None)
        self._several = several
        self.is_flat = self._cells.shape[1] in (3, 6) and bool(np.ptp(self._points[:, 2]) == 0)
        self._inverted = [surface.inverted_cells(step) for step in steps]
        self.notes = []
        self._fit(most_bytes)

    def _fit(self, most_bytes):
        plan = Plan(list(range(len(self._all))))
        while True:
            self._pack(plan)
            if len(self.text) <= most_bytes:
                break
            too_large = len(self.text) / most_bytes
            if plan.all_columns and self._has_columns():
                plan.all_columns = False
            elif len(plan.steps) > 3:
                plan.steps = _fewer(plan.steps, max(3, int(len(plan.steps) / min(too_large, 2))))
            elif self._triangle_count < 500:
                break
            else:
                plan.triangles = int(self._triangle_count / min(1.2 * too_large, 4))
        self.steps = plan.steps
        if not plan.all_columns:
            self.notes.append("Of vectors and tensors only the magnitude is here.")
        if len(plan.steps) < len(self._all):
            self.notes.append(f"{len(plan.steps)} of {len(self._all)} steps are here.")
        if plan.triangles:
            self.notes.append(f"The surface was thinned from {len(self._surface.triangles):,} to "
                              f"{self._triangle_count:,} triangles.")
        if any((self.inverted(step) or 0) > MOST_INVERTED for step in plan.steps):
            self.notes.append(f"Of inverted elements inside the body {MOST_INVERTED:,} are drawn.")

    def _has_columns(self):
        return any(field.ndim > 1 for field in self._all[-1].fields.values())

    def _pack(self, plan):
        pack = Pack()
        triangles, cells = self._surface.triangles, self._surface.cells
        edges = self._surface.edges
        if plan.triangles:
            stay, triangles = surface.thinned(self._points, triangles, plan.triangles)
            cells, edges = cells[stay], np.zeros((0, 2), dtype=int)
        self._triangle_count = len(triangles)
        inside = {step: self._inverted_edges(step) for step in plan.steps}
        vertices = np.unique(np.concatenate([triangles.ravel(), *map(np.ravel, inside.values())]))
        place = np.zeros(len(self._points), dtype=np.int64)
        place[vertices] = np.arange(len(vertices))
        shown, cell_of = np.unique(cells, return_inverse=True)

        rest = self._points[vertices]
        center = (rest.min(axis=0) + rest.max(axis=0)) / 2
        pack.add_reals("rest", rest - center)
        pack.add_numbers("vertices", vertices)
        pack.add_numbers("cells", shown)
        pack.add_numbers("triangles", place[triangles])
        pack.add_numbers("triangle_cells", cell_of)
        groups = self._regions[cells] if self._several else None
        pack.add_numbers("smooth", surface.smoothing_groups(self._points, triangles, groups))
        pack.add_numbers("edges", place[edges])
        pack.add_numbers("outline", place[surface.feature_edges(self._points, triangles, groups)])
        if self._several:
            pack.add_numbers("triangle_regions", groups)
        for number, step in enumerate(plan.steps):
            displacement = self._all[step].fields.get("displacement", np.zeros_like(self._points))
            pack.add_reals(f"u{number}", displacement[vertices])
            wrong = np.isin(cells, [] if self._inverted[step] is None else self._inverted[step])
            pack.add_numbers(f"marked{number}", np.flatnonzero(wrong))
            pack.add_numbers(f"inside{number}", place[inside[step]])
        if self._obstacles:
            self._pack_obstacles(pack, plan, center)
        described = self._pack_fields(pack, plan, vertices, shown)
        self.text = pack.text()
        self.manifest = {
            "flat": self.is_flat, "center": center.tolist(), "index": pack.index, "fields": described,
            "regions": sorted(set(self._regions.tolist())) if self._several else [],
            "regionNames": list(self._region_names),
            "quadratic": self._cells.shape[1] in (6, 10),
            "lengthUnit": self._units.of("length"), "obstacles": bool(self._obstacles),
            "steps": [{"t": self._all[step].t, "inverted": self.inverted(step)}
                      for step in plan.steps]}

    def _pack_obstacles(self, pack, plan, center):
        rest = self._obstacles.at(0, scale=0)
        pack.add_reals("obstacles", rest - center)
        pack.add_numbers("obstacle_triangles", self._obstacles.triangles)
        for number, step in enumerate(plan.steps):
            pack.add_reals(f"obstacles{number}", self._obstacles.at(step) - rest)

    def _pack_fields(self, pack, plan, vertices, shown):
        described = []
        for name, on_vertices in self._names(plan.steps):
            rows = vertices if on_vertices else shown
            twin = not on_vertices and name in self._all[-1].vertex_fields
            key = name + (" of cells" if twin else "")
            parts = {}  # column -> its least and largest value in each step, on the surface
            for number, step in enumerate(plan.steps):
                found = self._all[step].vertex_fields if on_vertices else self._all[step].cell_fields
                chosen = fields.columns(name, found[name][rows])
                if not plan.all_columns:
                    chosen = dict(list(chosen.items())[:1])
                for column, values in chosen.items():
                    finite = values[np.isfinite(values)]
                    span = [float(finite.min()), float(finite.max())] if finite.size else [0, 0]
                    # A few extreme cells do not decide the scale.
                    most = np.percentile(finite, [1, 99]).tolist() if finite.size else [0, 0]
                    parts.setdefault(column, []).append(span + (span if on_vertices else most))
                    pack.add_reals(f"{key}/{column}/{number}", values)
            described.append({
                "name": key, "title": fields.title(name) + (", by cell" if twin else ""), "unit": fields.unit(name, self._units),
                "onVertices": on_vertices, "labels": name in fields.LABEL_FIELDS, "columns": parts})
        return described

    def _names(self, steps):
        """Names of the fields that all the steps have, and whether they are on vertices."""
        last = self._all[-1]
        pairs = [(name, True) for name in last.vertex_fields] + [(name, False) for name in last.cell_fields]
        return [(name, on_vertices) for name, on_vertices in pairs
                if all(name in (self._all[step].vertex_fields if on_vertices
                                else self._all[step].cell_fields) for step in steps)]

    def inverted(self, step):
        """How many cells of a step are turned inside out; None: not known."""
        return None if self._inverted[step] is None else len(self._inverted[step])

    def _inverted_edges(self, step):
        """Edges (m x 2) of the cells that are inverted: most of these lie inside the body."""
        cells = self._cells[[] if self._inverted[step] is None else self._inverted[step][:MOST_INVERTED]]
        corners = [[0, 1], [1, 2], [2, 0]]
        if self._cells.shape[1] in (4, 10):
            corners += [[0, 3], [1, 3], [2, 3]]
        return np.unique(np.sort(cells[:, corners].reshape(-1, 2), axis=1), axis=0)


def _fewer(steps, count):
    """`count` of the steps, evenly, the first and the last among them."""
    return [steps[k] for k in np.unique(np.linspace(0, len(steps) - 1, count).round().astype(int))]
