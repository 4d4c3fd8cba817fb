"""How far the answers of programs are apart: compare_programs.py NAME=COMMAND NAME=COMMAND.."""

import sys
import tempfile
from pathlib import Path

import answers


def main(arguments):
    programs = [answers.Program(name, str(Path(command).resolve()))
                for name, command in (argument.split("=", 1) for argument in arguments)]
    beyond = []
    print(answers.table_head("program"))
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        answers.make_inputs(programs[0], folder)
        expected = None
        for program in programs:
            found = answers.answers(program, folder, folder / f"of {program.name}")
            expected = expected or found
            difference = answers.compare(expected, found)
            print(answers.table_row(program.name, difference), flush=True)
            beyond += [f"{program.name}: {line}" for line in difference.beyond()]
    print("\n".join(beyond))
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
