"""One store on disk for all that is expensive: values, their files, the keys they go by."""
