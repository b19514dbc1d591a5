"""Configuration of the IPython kernel for builds of the pages: no messages, no history."""

c = get_config()  # type: ignore[name-defined]  # noqa: F821

# Hide the message that the kernel listens on this machine only.
c.IPKernelApp.log_level = "ERROR"
c.HistoryManager.enabled = False
