//! What serves predictions where nothing is named: the effects that were found, or these and a field of friction beside them, whichever brings the
//! stops of strikes that were left out of its fits nearest. A form that is not the true one still predicts better than none where strikes were
//! made, and claims no name. It need not bring stops nearer by itself, if it predicts tracks better: what is learnt on top may do the rest.

use world::World;

use crate::{
    DiagnoseError,
    candidates::Candidate,
    diagnosis::SmoothMap,
    fit::Fitted,
    fitted_world::fitted_world,
    heldout::{self, Gains},
    noise::FrameNoise,
    null::renewed,
    screen::Chance,
    search::{Selection, beside},
    words::Note,
};

/// Share of the squared stop error that a smooth field must take for a field to be fitted.
const WORTH: f64 = 0.2;

/// The world that serves predictions, and the note that says so; none where nothing predicts stops or tracks better than the world without effects,
/// beyond chance.
pub(crate) fn carried(
    selection: &Selection<'_>,
    gains: &Gains,
    fields: &[Candidate],
    maps: &[SmoothMap],
    chance: &Chance,
    identified: &World,
) -> Result<Option<(World, Note)>, DiagnoseError> {
    let mut models: Vec<(Fitted, FrameNoise, Gains)> = Vec::new();
    let Selection { prepared, .. } = selection;
    if !selection.effects.is_empty() {
        models.push((selection.fitted.clone(), prepared.noise, gains.clone()));
    }
    let is_worth = |field: &&Candidate| {
        let of = |map: &&SmoothMap| field.name.starts_with(&*map.name) && map.share > WORTH;
        maps.iter().any(|map| of(&map))
    };
    for field in fields.iter().filter(is_worth) {
        let Some(fitted) = beside(selection, field, chance)? else {
            continue;
        };
        if let Some((prepared, null, fitted)) = renewed(prepared, &selection.null, &fitted)? {
            let gains = heldout::gains(&prepared, &null, &fitted)?;
            models.push((fitted, prepared.noise, gains));
        }
    }
    let typical = prepared.thresholds.typical_gains;
    let pays = |gains: &[f64]| heldout::is_beyond_chance(&heldout::limited(gains, typical));
    let nearer = |gains: &Gains| heldout::total(&gains.stop).0;
    let best = models
        .into_iter()
        .filter(|(_, _, gains)| pays(&gains.stop) || pays(&gains.likelihood))
        .max_by(|a, b| nearer(&a.2).total_cmp(&nearer(&b.2)));
    let Some((fitted, noise, gains)) = best else {
        return Ok(None);
    };
    let world = fitted_world(identified, &fitted, noise)?;
    let note = Note::Carried {
        effects: world.effects.clone(),
        nearer: nearer(&gains) / gains.stop.len().max(1) as f64,
    };
    Ok(Some((world, note)))
}
