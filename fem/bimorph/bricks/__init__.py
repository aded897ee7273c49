"""The solid on bricks of high order."""
