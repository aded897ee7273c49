"""What lies beside a report: its numbers, their origin, checksums; and computing it again."""
