"""The index hash of the SaarCOR virtual memory, speaking saarcor-hash over stdin and stdout (PROTOCOL.md)."""

import sys


def set_of(line, sets, hash):
    upper = line // sets
    if hash == "low" or sets == 1:
        return line % sets
    if hash == "add-upper":
        return (line + upper) % sets
    total = line
    while upper:
        total += upper % sets
        upper //= sets
    return total % sets


config = {}
for request in sys.stdin:
    name, *words = request.split() or ["#"]
    if name == "s":
        print(f"{set_of(int(words[0], 16), int(config['sets']), config['hash']):x}")
    elif name == "config":
        config = dict(word.split("=") for word in words)
        print("ok observes=set")
    elif name == "saarcor-hash":
        print("saarcor-hash 1")
    elif name == "end":
        print("end")
        break
