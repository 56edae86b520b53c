//! Stop errors, summed up model by model.

use std::collections::BTreeMap;

use values::StopErrors;

/// Sums up errors in m, none where there is no prediction. A model without any prediction has no statistics.
pub(crate) fn summarise<'m>(
    errors: impl Iterator<Item = (&'m str, Option<f64>)>,
) -> BTreeMap<String, StopErrors> {
    let mut of_models: BTreeMap<&str, (Vec<f64>, usize)> = BTreeMap::new();
    for (model, error) in errors {
        let (known, failed) = of_models.entry(model).or_default();
        match error {
            Some(error) => known.push(error),
            None => *failed += 1,
        }
    }
    let summed = of_models
        .into_iter()
        .filter_map(|(model, (known, failed))| {
            let errors = StopErrors::of(known.into_iter())?;
            Some((model.to_string(), StopErrors { failed, ..errors }))
        });
    summed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_summed_up_apart() {
        let rows = [
            ("a", Some(1.0)),
            ("b", Some(7.0)),
            ("a", Some(2.0)),
            ("c", None),
            ("a", None),
        ];
        let all = summarise(rows.into_iter());
        assert_eq!((all["a"].mean, all["a"].n, all["a"].failed), (1.5, 2, 1));
        assert_eq!((all["b"].mean, all["b"].sd, all["b"].n), (7.0, 0.0, 1));
        assert!(
            !all.contains_key("c"),
            "a model without a prediction has no statistics"
        );
    }
}
