def evaluate_all(arguments):
    pass
