"""Fast evaluation of batches: choice of nodes, blocks of points, compiled programs, gradients."""
