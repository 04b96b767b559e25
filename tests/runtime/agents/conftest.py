"""What several tests share."""

from served_agents import limits, served, service

__all__ = ["limits", "served", "service"]
