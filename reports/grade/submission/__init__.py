"""What a student submits: found, unpacked safely, built, and ready to be judged."""
