"""Escape sequences in names of strangers: no terminal obeys them."""

import io

from rich.progress import Progress, TextColumn
from rich.text import Text

from luxloop.console import PrintableConsole
from luxloop.printable import print_text, printable
from luxloop.scenarios.cli import main
from luxloop.scenarios.document.document import Answer, Document, Paragraph, Section, Table
from luxloop.scenarios.report.text import as_text

CLEAR, BACKWARDS, CSI = MARKS = "\x1b[2J", "\u202e", "\x9b"
NAME = f"car{CLEAR}{BACKWARDS}{CSI}1m\udc80"
SHOWN = r"car\x1b[2J\u202e\x9b1m\udc80"


def test_marks_are_escaped_and_lines_and_letters_of_all_languages_are_not():
    assert printable(NAME) == SHOWN
    assert printable("a\r\nb\tc") == "a\\r\nb\\tc"
    assert printable("Überholspur 車 🚗\n") == "Überholspur 車 🚗\n"


def test_printed_text_is_printable(capsys):
    print_text(NAME)
    assert capsys.readouterr().out == SHOWN + "\n"


def test_documents_show_names_escaped_in_answers_paragraphs_and_tables():
    table = Table(f"title {NAME}")
    table.add_column("name")
    table.add_row(f"cell {NAME}")
    shown = Document("head", Answer(f"answer {NAME}"), [], [Section("s", "S", [table, Paragraph(f"words {NAME}")])])
    text = as_text(shown)
    assert text.count(r"car\x1b") == 4
    assert not any(mark in text for mark in MARKS)


def test_a_terminal_gets_the_colours_and_bars_of_luxloop_only():
    out = io.StringIO()
    console = PrintableConsole(file=out, force_terminal=True, color_system="standard", width=100)
    console.print(Text(NAME, "green"))
    assert f"\x1b[32m{SHOWN}\x1b[0m" in out.getvalue()
    with Progress(TextColumn("{task.description}", markup=False), console=console) as bar:
        bar.add_task(NAME)
    assert out.getvalue().count(r"car\x1b") > 1
    assert not any(mark in out.getvalue() for mark in MARKS)


def test_an_error_names_a_file_with_its_marks_escaped(capsys):
    assert main(["run", f"{CLEAR}{BACKWARDS}.toml"]) == 2
    assert r"\x1b[2J\u202e.toml" in capsys.readouterr().err
