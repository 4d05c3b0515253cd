"""PLY files as arrays, read with meshio.

Its version 5.0 takes unsigned bytes above 127 for negative: colours and polygons of so many corners come out wrong.
"""

import meshio
import numpy as np

COVARIANCE = "covxx", "covxy", "covxz", "covxy", "covyy", "covyz", "covxz", "covyz", "covzz"


class Ply:
    """Vertices and faces of a PLY file, text or binary."""

    def __init__(self, path):
        mesh = meshio.read(path, "ply")
        self.path, self.columns = path, mesh.point_data
        self.positions = mesh.points.astype(float)  # (n, 3)
        self.blocks = [cells.data for cells in mesh.cells]  # (m, k) of faces with k corners each, in their order

    def __len__(self):
        return len(self.positions)

    def has(self, column):
        return column in self.columns

    def vectors(self, *names):
        """Columns of the vertices side by side: (n, len(names))."""
        return np.stack([self.columns[name].astype(float) for name in names], axis=1)

    def normals(self):
        return self.vectors("nx", "ny", "nz")

    def covariances(self):
        """(n, 3, 3)"""
        return self.vectors(*COVARIANCE).reshape(-1, 3, 3)

    def faces(self):
        """(m, k) where all have k corners; raises ValueError where they differ."""
        if len({block.shape[1] for block in self.blocks}) != 1:
            raise ValueError(f"{self.path}: expected faces of one size")
        return np.concatenate(self.blocks).astype(int)
