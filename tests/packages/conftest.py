"""The packages here are somebody else's: their tests run where they are installed, not with ours."""

collect_ignore_glob = ["homebot-*"]
