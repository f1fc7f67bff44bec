"""Reads what the program writes: XDMF with HDF5, also series of steps, and VTU."""
import base64
import os
import re
import xml.etree.ElementTree
import zlib

import h5py
import numpy as np


class Step:
    """One state of a file: `points` n x 3 with the displacement added, `cells` m x corners."""

    def __init__(self, name, points, cells):
        self.name, self.points, self.cells = name, points, cells


def steps_of(path):
    """All states of a file, one after the other."""
    if path.endswith(".xdmf"):
        return _xdmf_steps(path)
    if path.endswith(".vtu"):
        return iter([_vtu_step(path)])
    raise ValueError(f"{path}: neither .xdmf nor .vtu")


def _corners(cells, path):
    if cells.shape[1] not in (3, 4):
        raise ValueError(f"{path}: cells of {cells.shape[1]} nodes; triangles and linear "
                         "tetrahedra have straight edges")
    return cells


# --- XDMF: the text says which dataset of which HDF5 file is what ---

def _dataset(item, folder):
    name, dataset = item.text.strip().rsplit(":", 1)
    with h5py.File(os.path.join(folder, name), "r") as file:
        return file[dataset][()]


def _find_reference(root, node):
    """A grid of a series may point to the topology of another: follows an xpath of names."""
    reference = node.get("Reference")
    if reference is None:
        return node
    target = node.text.strip() if reference == "XML" else reference
    return root.find("." + re.sub(r"^/?Xdmf", "", target))


def _xdmf_steps(path):
    folder = os.path.dirname(path)
    root = xml.etree.ElementTree.parse(path).getroot()
    for number, grid in enumerate(g for g in root.iter("Grid") if g.get("GridType") != "Collection"):
        parts = {part: _find_reference(root, grid.find(part)).find("DataItem")
                 for part in ("Topology", "Geometry")}
        points = _dataset(parts["Geometry"], folder)
        cells = _corners(_dataset(parts["Topology"], folder), path)
        for attribute in grid.findall("Attribute"):
            if attribute.get("Name") == "displacement":
                points = points + _dataset(attribute.find("DataItem"), folder)
        time = grid.find("Time")
        yield Step(f"step {number}" if time is None else f"t = {time.get('Value')}", points, cells)


# --- VTU: arrays as text, in base64, or raw at the end of the file ---

NUMBERS = {"Float32": "f4", "Float64": "f8", "Int8": "i1", "UInt8": "u1", "Int32": "i4",
           "UInt32": "u4", "Int64": "i8", "UInt64": "u8"}


class _Vtu:
    def __init__(self, path):
        with open(path, "rb") as file:
            content = file.read()
        start = re.search(rb"<AppendedData[^>]*>\s*_", content)
        self.appended, self.encoding = b"", None
        if start:
            end = content.rindex(b"</AppendedData>")
            self.appended = content[start.end():end]
            self.encoding = "base64" if b"base64" in start.group() else "raw"
            content = content[:start.end()] + content[end:]
        self.root = xml.etree.ElementTree.fromstring(content)
        order = "<" if self.root.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        self.order = order
        self.header = np.dtype(order + NUMBERS[self.root.get("header_type", "UInt32")])
        self.compressed = "compressor" in self.root.attrib

    def pieces(self):
        return self.root.iter("Piece")

    def array(self, node):
        if node.get("format") == "ascii":
            numbers = np.array((node.text or "").split(), dtype=NUMBERS[node.get("type")])
        else:
            numbers = np.frombuffer(self._bytes(node),
                                    dtype=self.order + NUMBERS[node.get("type")])
        components = int(node.get("NumberOfComponents", "1"))
        return numbers.reshape(-1, components) if components > 1 else numbers

    def _bytes(self, node):
        if node.get("format") == "appended":
            data = self.appended[int(node.get("offset")):]
            encoded = self.encoding == "base64"
        else:
            data, encoded = node.text.strip().encode(), True
        size = self.header.itemsize
        if not self.compressed:
            if encoded:
                data = base64.b64decode(data[:len(data) // 4 * 4])
            length = int(np.frombuffer(data[:size], self.header)[0])
            return data[size:size + length]
        decode = (lambda text, length: base64.b64decode(text[:4 * -(-length // 3)])) if encoded \
            else (lambda raw, length: raw[:length])
        blocks = int(np.frombuffer(decode(data, 3 * size)[:size], self.header)[0])
        head = decode(data, (3 + blocks) * size)
        sizes = np.frombuffer(head[3 * size:(3 + blocks) * size], self.header).astype(int)
        skip = 4 * -(-(3 + blocks) * size // 3) if encoded else (3 + blocks) * size
        packed = decode(data[skip:], int(sizes.sum()))
        ends = np.cumsum(sizes)
        return b"".join(zlib.decompress(packed[end - length:end])
                        for end, length in zip(ends, sizes))


def _vtu_step(path):
    """The pieces of the ranks put together: what is at the same place at rest is the same."""
    file = _Vtu(path)
    all_rest, all_moved, all_cells, first = [], [], [], 0
    for piece in file.pieces():
        rest = file.array(piece.find("Points/DataArray"))
        if len(rest) == 0:
            continue
        cells = {node.get("Name"): file.array(node) for node in piece.findall("Cells/DataArray")}
        moved = rest
        for node in piece.findall("PointData/DataArray"):
            if node.get("Name") == "displacement":
                moved = rest + file.array(node)
        corners = np.diff(np.concatenate(([0], cells["offsets"])))
        if len(set(corners)) > 1:
            raise ValueError(f"{path}: cells of several kinds")
        all_rest.append(rest)
        all_moved.append(moved)
        all_cells.append(cells["connectivity"].reshape(len(corners), -1) + first)
        first += len(rest)
    points, cells = np.concatenate(all_moved), np.concatenate(all_cells)
    if len(all_rest) > 1:
        _, keep, number = np.unique(np.concatenate(all_rest), axis=0, return_index=True,
                                    return_inverse=True)
        points, cells = points[keep], number[cells]
    return Step(os.path.basename(path), points, _corners(cells, path))
