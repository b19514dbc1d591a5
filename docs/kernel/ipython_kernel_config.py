"""IPython's kernel as a build wants it: quiet, and without a memory."""

c = get_config()  # type: ignore[name-defined]  # noqa: F821

# That the kernel listens on this machine alone is no news.
c.IPKernelApp.log_level = "ERROR"
c.HistoryManager.enabled = False
