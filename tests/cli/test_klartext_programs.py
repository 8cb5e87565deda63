"""CALL PGM finds files beside the program, by the name that a control would use."""


def test_called_programs_come_from_the_folder(run, tmp_path):
    (tmp_path / "main.h").write_text(
        "BEGIN PGM M MM\nL X+1 F100\nCALL PGM TNC:\\jobs\\SIDE.H ; COMMENT\nEND PGM M MM\n"
    )
    (tmp_path / "side.h").write_text("BEGIN PGM S MM\nL Y+7\nEND PGM S MM\n")
    answer = run("dump", "moves", tmp_path / "main.h")
    assert (answer.code, answer.err) == (0, "")
    assert '"end": [1.0, 7.0,' in answer.out
    (tmp_path / "side.h").write_text("BEGIN PGM S MM\nL Y+7 Q\nEND PGM S MM\n")
    assert "main.h:3: VP001 error: side.h, line 2: " in run("dump", "moves", tmp_path / "main.h").err
