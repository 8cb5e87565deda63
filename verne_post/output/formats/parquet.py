"""Apache Parquet with the columns of the CSV, compressed; needs pyarrow (extra ``parquet``).

The metadata of its schema says what the rows were made of: ``verne_post.program`` and so on.
"""

import io
from collections.abc import Iterator
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import READ_ROWS, check_names, name_columns, read_exact_blocks, take_columns
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write one table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = rows.name_columns()
    types = [pa.float64()] * (len(names) - 1) + [pa.int32()]
    about = {f"verne_post.{key}": value for key, value in rows.about.items()}
    schema = pa.schema(list(zip(names, types, strict=True)), metadata=about)
    buffer = io.BytesIO()
    with pq.ParquetWriter(buffer, schema) as writer:
        for block in rows.iterate_blocks():
            arrays = [pa.array(column) for column in take_columns(block)]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
    yield buffer.getvalue()


def read(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read the table in parts."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        text = "to read parquet, install the extra parquet (pyarrow), as with pip install verne-post[parquet]"
        raise make_input_error("VP020", text, file=expected.name) from None
    try:
        with pq.ParquetFile(stream) as file:
            check_names(file.schema_arrow.names, name_columns(expected.columns, expected.drives), expected.name)

            def take_tables() -> Iterator[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]]:
                for batch in file.iter_batches(batch_size=READ_ROWS):
                    t, *joints, line = (column.to_numpy(zero_copy_only=False) for column in batch.columns)
                    yield np.stack(joints, axis=1), t, line

            yield from read_exact_blocks(take_tables(), expected)
    except (pa.ArrowException, TypeError) as error:
        raise make_input_error("VP020", f"no parquet file: {error}", file=expected.name) from None


def recognize(head: bytes, expected: Expected) -> bool:
    """The mark of parquet."""
    return head.startswith(b"PAR1")


FORMAT: Final = FileFormat(
    write,
    ".parquet",
    WrittenRows.name_columns,
    needs="pyarrow",
    has_undriven=True,
    read=read,
    recognize=recognize,
    is_archive=True,
)
