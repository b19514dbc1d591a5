"""What a flight log tells before anything is fitted to it: plausibility, steady stretches."""
