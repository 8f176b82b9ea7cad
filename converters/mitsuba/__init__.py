"""A scene in Mitsuba 3's language."""
