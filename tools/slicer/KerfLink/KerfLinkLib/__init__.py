"""The part of the module KerfLink that needs no 3D Slicer."""
