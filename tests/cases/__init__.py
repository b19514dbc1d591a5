"""Cases of users, re-made small, by the commands that they type."""
