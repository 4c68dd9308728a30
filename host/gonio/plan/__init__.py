"""From a plan in directions to paths of the axes, each checked as the firmware will check it."""
