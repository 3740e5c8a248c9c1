"""Reads an export for ParaView as strictly as ParaView does: every array as long as it must be.

usage: read_vtk.py DIRECTORY. Prints a line per data set of each collection.
"""
import pathlib
import sys
import xml.etree.ElementTree as xml

directory = pathlib.Path(sys.argv[1])
kinds = {"Float32": float, "Float64": float, "UInt8": int, "UInt16": int, "UInt32": int, "Int32": int}


def numbers(array):
    values = [kinds[array.get("type")](word) for word in array.text.split()]
    assert array.get("format") == "ascii"
    assert len(values) % int(array.get("NumberOfComponents")) == 0
    return values


def points_of(root):
    piece = root.find("PolyData/Piece")
    count = int(piece.get("NumberOfPoints"))
    assert len(numbers(piece.find("Points/DataArray"))) == 3 * count
    verts = {array.get("Name"): numbers(array) for array in piece.findall("Verts/DataArray")}
    assert int(piece.get("NumberOfVerts")) == count
    assert verts == {"connectivity": list(range(count)), "offsets": list(range(1, count + 1))}
    data = {array.get("Name"): numbers(array) for array in piece.findall("PointData/DataArray")}
    assert all(len(values) == count for values in data.values())
    return f"points {count} ids {' '.join(map(str, data['id']))}".rstrip() if "id" in data else \
        f"points {count}"


def squares_of(root):
    image = root.find("ImageData")
    extent = [int(word) for word in image.get("WholeExtent").split()]
    assert extent[0] == extent[2] == extent[4] == extent[5] == 0
    assert image.find("Piece").get("Extent") == image.get("WholeExtent")
    assert len(image.get("Origin").split()) == len(image.get("Spacing").split()) == 3
    for array in image.findall("Piece/CellData/DataArray"):
        assert len(numbers(array)) == extent[1] * extent[3]
    return f"squares {extent[1] * extent[3]} of {extent[1]} {extent[3]}"


listed = set()
for collection in sorted(directory.glob("*.pvd")):
    root = xml.parse(collection).getroot()
    assert root.get("type") == "Collection"
    for item in root.findall("Collection/DataSet"):
        listed.add(item.get("file"))
        data = xml.parse(directory / item.get("file")).getroot()
        read = {"PolyData": points_of, "ImageData": squares_of}[data.get("type")]
        print(collection.name, item.get("timestep"), read(data))
assert listed == {file.name for file in directory.iterdir() if file.suffix != ".pvd"}
