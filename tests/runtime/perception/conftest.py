"""What several tests share."""

from onnx_graphs import constant_graph, encoder

__all__ = ["constant_graph", "encoder"]
