"""Fixtures that several rooms' tests share: a service on a bus, and our server for agents beside
it. A room's conftest names those that it uses."""

from collections.abc import Iterator

import pytest
from agent_client import Served
from agent_service import AgentService

from runtime.agents.tools import AgentLimits


@pytest.fixture
def service() -> Iterator[AgentService]:
    with AgentService().up() as service:
        yield service


@pytest.fixture
def limits() -> AgentLimits:
    """Of whoever started the server."""
    return AgentLimits()


@pytest.fixture
def served(service: AgentService, limits: AgentLimits) -> Iterator[Served]:
    with Served(service, limits, "").up() as served:
        yield served
