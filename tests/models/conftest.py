"""What several tests share."""

from onnx_graphs import constant_graph, encoder, prompted_graph

__all__ = ["constant_graph", "encoder", "prompted_graph"]
