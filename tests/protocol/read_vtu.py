#!/usr/bin/env python3
"""Reads an ASCII .vtu with Python's own XML reader and prints its counts and arrays, for vtk_file_test.cpp."""

import sys
import xml.etree.ElementTree as ElementTree

root = ElementTree.parse(sys.argv[1]).getroot()
assert root.tag == "VTKFile" and root.get("type") == "UnstructuredGrid"
piece = root.find("UnstructuredGrid/Piece")
points = int(piece.get("NumberOfPoints"))
cells = int(piece.get("NumberOfCells"))
print(points, cells)


def show(array, tuples):
    assert array.get("format") == "ascii"
    components = int(array.get("NumberOfComponents"))
    values = array.text.split()
    assert tuples is None or len(values) == tuples * components
    print(array.get("Name"), components, array.get("type"))
    print(" ".join(values))


(coordinates,) = piece.findall("Points/DataArray")
show(coordinates, points)
arrays = {array.get("Name"): array for array in piece.findall("Cells/DataArray")}
show(arrays["connectivity"], None)
show(arrays["offsets"], cells)
show(arrays["types"], cells)
for field in piece.findall("PointData/DataArray"):
    show(field, points)
