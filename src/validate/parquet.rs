//! Rows as Parquet: the same columns as the CSV, typed, for tools that query thousands of runs.

use super::row::{Column, Row};
use super::table::{TEXTS, epoch_names, numbers, outcome};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::sync::Arc;

/// Writes `rows` as one row group, without compression and with nothing in it that depends on the
/// day or the machine. `complete` tells whether the campaign ran to its end.
///
/// # Errors
/// Those of `out`.
pub fn write_parquet(rows: &[Row], complete: bool, out: &mut dyn Write) -> io::Result<()> {
    write(rows, complete, out).map_err(io::Error::other)
}

fn write(rows: &[Row], complete: bool, out: &mut dyn Write) -> Result<(), ParquetError> {
    let complete = KeyValue::new("complete".to_owned(), complete.to_string());
    let properties = WriterProperties::builder()
        .set_created_by(concat!("struna ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_key_value_metadata(Some(vec![complete]))
        .build();
    // The writer wants something that can be sent to other threads.
    let mut file = SerializedFileWriter::new(Vec::new(), schema()?, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    let text = |of: &dyn Fn(&Row) -> &str| -> Vec<ByteArray> {
        rows.iter().map(|row| ByteArray::from(of(row))).collect()
    };
    write_texts(&mut group, &text(&|row| row.suite))?;
    write_texts(&mut group, &text(&|row| &row.case))?;
    write_texts(&mut group, &text(&|row| &row.estimator))?;
    let runs: Vec<i64> = rows.iter().map(|row| i64::from(row.run)).collect();
    write_integers(&mut group, &runs)?;
    // Unsigned 64 bits have a type of their own over the signed one: the bits are the same.
    let seeds: Vec<i64> = rows.iter().map(|row| row.seed.cast_signed()).collect();
    write_integers(&mut group, &seeds)?;
    write_texts(&mut group, &text(&outcome))?;
    write_texts(&mut group, &text(&|row| row.status))?;
    let table: Vec<Vec<Option<f64>>> = rows.iter().map(|row| numbers(row).collect()).collect();
    for column in 0..Column::ALL.len() + epoch_names().len() {
        let cells: Vec<Option<f64>> = table.iter().map(|row| row[column]).collect();
        write_numbers(&mut group, &cells)?;
    }
    group.close()?;
    let bytes = file.into_inner()?;
    out.write_all(&bytes).map_err(|error| ParquetError::External(Box::new(error)))
}

fn schema() -> Result<Arc<Type>, ParquetError> {
    let field = |name: &str, physical, converted, repetition| {
        let field = Type::primitive_type_builder(name, physical)
            .with_converted_type(converted)
            .with_repetition(repetition)
            .build();
        field.map(Arc::new)
    };
    let mut fields = Vec::new();
    for name in TEXTS {
        let (physical, converted) = match name {
            "run" => (Physical::INT64, ConvertedType::NONE),
            "seed" => (Physical::INT64, ConvertedType::UINT_64),
            _ => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
        };
        fields.push(field(name, physical, converted, Repetition::REQUIRED)?);
    }
    let names = Column::ALL.iter().map(|column| column.name().to_owned()).chain(epoch_names());
    for name in names {
        let (physical, converted) = (Physical::DOUBLE, ConvertedType::NONE);
        fields.push(field(&name, physical, converted, Repetition::OPTIONAL)?);
    }
    Ok(Arc::new(Type::group_type_builder("rows").with_fields(fields).build()?))
}

type Group<'a> = SerializedRowGroupWriter<'a, Vec<u8>>;

fn write_texts(group: &mut Group<'_>, values: &[ByteArray]) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Err(beyond()) };
    column.typed::<ByteArrayType>().write_batch(values, None, None)?;
    column.close()
}

fn write_integers(group: &mut Group<'_>, values: &[i64]) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Err(beyond()) };
    column.typed::<Int64Type>().write_batch(values, None, None)?;
    column.close()
}

/// Numbers of which some are missing: those there are, and a level of one where one is.
fn write_numbers(group: &mut Group<'_>, cells: &[Option<f64>]) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Err(beyond()) };
    let values: Vec<f64> = cells.iter().flatten().copied().collect();
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
    column.close()
}

fn beyond() -> ParquetError {
    ParquetError::General("more columns written than the schema has".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::Outcome;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    #[test]
    fn what_is_written_reads_back_and_what_is_missing_is_null() {
        let mut row = Row::new("limits", "A", "F1 N=100", (u64::MAX, 7));
        row.set(Column::PeriodS, 480.25);
        row.outcome = Outcome::Stopped("no number".to_owned());
        let mut bytes = Vec::new();
        write_parquet(&[row], false, &mut bytes).unwrap();
        let file = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let notes = file.metadata().file_metadata().key_value_metadata().unwrap();
        assert_eq!(notes[0].value.as_deref(), Some("false"));
        let row = file.get_row_iter(None).unwrap().next().unwrap().unwrap();
        let cell = |name: &str| {
            row.get_column_iter().find(|(at, _)| *at == name).map(|(_, field)| field.clone())
        };
        assert_eq!(cell("estimator"), Some(Field::Str("F1 N=100".to_owned())));
        assert_eq!(cell("run"), Some(Field::Long(7)));
        assert_eq!(cell("seed"), Some(Field::ULong(u64::MAX)));
        assert_eq!(cell("outcome"), Some(Field::Str("no number".to_owned())));
        assert_eq!(cell("period_s"), Some(Field::Double(480.25)));
        assert_eq!(cell("damping_ratio"), Some(Field::Null));
        assert_eq!(row.len(), TEXTS.len() + Column::ALL.len() + epoch_names().len());
    }
}
