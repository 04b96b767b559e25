"""The operator's page: a process beside the runtime that shows people what it does, and asks it
what they ask. The protocol is in docs/view.md."""
