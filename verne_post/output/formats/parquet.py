"""Apache Parquet with the columns of the CSV, compressed; needs pyarrow (extra ``parquet``).

The metadata of its schema says what the rows were made of: ``verne_post.program`` and so on.
"""

import io
from collections.abc import Iterator
from typing import Final

from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import take_columns
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


FORMAT: Final = FileFormat(write, ".parquet", WrittenRows.name_columns, needs="pyarrow", has_undriven=True)
