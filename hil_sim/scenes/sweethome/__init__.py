"""Sweet Home 3D drawings as scenes."""
