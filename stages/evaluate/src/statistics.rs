//! Stop errors, summed up model by model.

use std::collections::BTreeMap;

use polars::prelude::*;
use values::StopErrors;

use crate::EvaluateError;

/// Sums up one error a row, none where there is no prediction. A model without any prediction has no statistics.
pub(crate) fn summarise(
    models: &[&str],
    errors: &[Option<f64>],
) -> Result<BTreeMap<String, StopErrors>, EvaluateError> {
    if models.is_empty() {
        return Ok(BTreeMap::new());
    }
    let table = df!("model" => models, "error" => errors)?;
    let summary = table.group_by_stable(["model"])?.apply(summarise_one)?;
    let models = summary.column("model")?.str()?;
    let number = |name: &str| Ok::<_, PolarsError>(summary.column(name)?.f64()?.clone());
    let count = |name: &str| Ok::<_, PolarsError>(summary.column(name)?.u64()?.clone());
    let (mean, sd, median, p95) = (
        number("mean")?,
        number("sd")?,
        number("median")?,
        number("p95")?,
    );
    let (n, failed) = (count("n")?, count("failed")?);
    let row = |index| {
        let statistics = StopErrors {
            mean: mean.get(index)?,
            sd: sd.get(index).unwrap_or(0.0),
            median: median.get(index)?,
            p95: p95.get(index)?,
            n: n.get(index)? as usize,
            failed: failed.get(index)? as usize,
        };
        Some((models.get(index)?.to_string(), statistics))
    };
    Ok((0..summary.height()).filter_map(row).collect())
}

fn summarise_one(group: DataFrame) -> PolarsResult<DataFrame> {
    let column = group.column("error")?.f64()?;
    let errors = column.drop_nulls();
    df!(
        "model" => [group.column("model")?.str()?.get(0)],
        "mean" => [errors.mean()],
        "sd" => [errors.std(1)],
        "median" => [errors.median()],
        "p95" => [errors.quantile(0.95, QuantileMethod::Linear)?],
        "n" => [errors.len() as u64],
        "failed" => [column.null_count() as u64],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_summed_up_apart() {
        let models = ["a", "b", "a", "a", "c", "a", "a"];
        let errors = [
            Some(1.0),
            Some(7.0),
            Some(2.0),
            Some(3.0),
            None,
            Some(4.0),
            None,
        ];
        let all = summarise(&models, &errors).expect("a table");
        let a = all["a"];
        assert_eq!((a.mean, a.median, a.n, a.failed), (2.5, 2.5, 4, 1));
        assert!((a.sd - (5.0f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((a.p95 - 3.85).abs() < 1e-12);
        assert_eq!((all["b"].mean, all["b"].sd, all["b"].n), (7.0, 0.0, 1));
        assert!(
            !all.contains_key("c"),
            "a model without a prediction has no statistics"
        );
    }

    #[test]
    fn no_strikes_no_statistics() {
        assert!(summarise(&[], &[]).expect("a table").is_empty());
    }
}
