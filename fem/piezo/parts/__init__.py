"""The solid in three parts joined at sections: two ends that are kept, and any length between."""
