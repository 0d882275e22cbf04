"""What changes a mesh: simulate, apply and sweep of each operator."""
