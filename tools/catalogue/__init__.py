"""Section constants of many propellers at once, held together by a prior over propellers."""
