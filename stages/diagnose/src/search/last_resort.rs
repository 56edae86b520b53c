//! A smooth field in the place of simpler effects of its kind, where it is likelier than all of them together.

use world::{WorldError, effects::effect};

use super::{
    Selection,
    fits::{FitCriteria, Tried, fit_best},
    refine::refine,
};
use crate::{
    candidates::Candidate,
    null::renewed,
    screen::{Chance, screen},
};

/// Asks each last resort whether it stands better than all effects of its kind together, which hold less than what explains a gap of what
/// it gains; where no effect is held, whether it stands at all.
pub(crate) fn with_last_resorts<'a>(
    mut selection: Selection<'a>,
    last_resorts: &[Candidate],
    candidates: &[Candidate],
    chance: &Chance,
) -> Result<Selection<'a>, WorldError> {
    for last_resort in last_resorts {
        let Selection {
            prepared, fitted, ..
        } = &selection;
        let kind = |name: &str| effect(name).ok().map(|spec| spec.family);
        let mut model = fitted.model.clone();
        let mut by_chance = 0.0;
        for place in (0..model.parts.len()).rev() {
            let name = model.parts[place].name;
            if kind(name) == kind(last_resort.name) {
                model = model.without(place);
                by_chance += chance[name];
            }
        }
        let thresholds = prepared.thresholds;
        let held = fitted.model.parts.len();
        if model.parts.len() == held && held > 0 {
            continue;
        }
        let Some(reduced) = prepared.fit_from(fitted, &model)? else {
            continue;
        };
        let simpler = (fitted.likelihood() - reduced.likelihood() - by_chance).max(0.0);
        let screened = screen(prepared, &reduced, std::slice::from_ref(last_resort))?;
        let criteria = FitCriteria {
            required: &[last_resort.name],
            ..FitCriteria::default()
        };
        let fits = fit_best(
            prepared,
            &reduced,
            &screened,
            chance,
            criteria,
            &mut Tried::new(),
        )?;
        let Some(fit) = fits.into_iter().find(|fit| {
            let gain = fit.fitted.likelihood() - reduced.likelihood();
            thresholds.explained * gain - chance[last_resort.name] > simpler + thresholds.better
        }) else {
            continue;
        };
        let Some((prepared, null, fitted)) = renewed(prepared, &selection.null, &fit.fitted)?
        else {
            continue;
        };
        selection = refine(
            Selection {
                prepared,
                null,
                fitted,
                effects: Vec::new(),
            },
            candidates,
            chance,
            0,
        )?;
    }
    Ok(selection)
}
