"""The sections of the page: each tells, tabulates and draws one part of the numbers."""
