"""All that exists for speed: plans, batches, compiled programs, gradients."""
