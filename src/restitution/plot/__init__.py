"""Pictures: functions that take and return matplotlib Axes and never show anything."""
