"""What rays meet: one file a shape, each with its rule's kernel and its normal."""
