"""Writer of Parquet files of rows that a full disk ends with one error."""

from contextlib import suppress

import pyarrow.parquet as pq


class RowWriter(pq.ParquetWriter):  # type: ignore[misc]  # pyarrow has no types
    """Parquet writer that closes its file once.

    After an error pyarrow's would close it again when it is collected, and print a traceback on standard error.
    """

    def close(self) -> None:
        """Close the file; after an error it counts as closed.

        Raises
        ------
        OSError
            The file cannot be written.
        """
        try:
            super().close()
        finally:
            self.is_open = False

    def __del__(self) -> None:
        with suppress(OSError):  # the error that ended the write is already on its way
            super().__del__()
