//! Adam: Kingma and Ba (2015), algorithm 1, in the order of the arithmetic that they end section 2 with.
//!
//! burn's own optimisers need its feature `std`, by which every one of its devices is locked: 300 crates that nothing here builds.

use burn::{
    module::{Module, ModuleMapper, Param},
    tensor::{Gradients, Tensor},
};

/// Decay rates of the first and second moment, and the term that keeps a step finite.
const FIRST: f32 = 0.9;
const SECOND: f32 = 0.999;
const EPSILON: f32 = 1e-5;

/// The optimiser's state.
#[derive(Default)]
pub(crate) struct Adam {
    steps: i32,
    /// First and second moments of each parameter's gradient, in the order in which a model is walked.
    moments: Vec<[Tensor<1>; 2]>,
}

impl Adam {
    /// A model after one step at this rate.
    pub(crate) fn step<M: Module>(&mut self, rate: f64, model: M, gradients: &Gradients) -> M {
        self.steps += 1;
        model.map(&mut Step {
            adam: self,
            rate,
            gradients,
            done: 0,
        })
    }
}

/// One step, on its way through a model.
struct Step<'a> {
    adam: &'a mut Adam,
    rate: f64,
    gradients: &'a Gradients,
    /// Parameters that were stepped.
    done: usize,
}

impl Step<'_> {
    /// By how much a parameter with this gradient goes down.
    fn by(&mut self, gradient: Tensor<1>) -> Tensor<1> {
        let Adam { steps, moments } = &mut *self.adam;
        let part = gradient.clone().mul_scalar(1.0 - FIRST);
        let square = gradient.square().mul_scalar(1.0 - SECOND);
        match moments.get_mut(self.done) {
            Some([first, second]) => {
                *first = first.clone().mul_scalar(FIRST).add(part);
                *second = second.clone().mul_scalar(SECOND).add(square);
            }
            None => moments.push([part, square]),
        }
        let [first, second] = moments[self.done].clone();
        self.done += 1;
        let root = (1.0 - SECOND.powi(*steps)).sqrt();
        let corrected = first.mul_scalar(root / (1.0 - FIRST.powi(*steps)));
        let step = corrected.div(second.sqrt().add_scalar(EPSILON * root));
        step.mul_scalar(self.rate)
    }
}

impl ModuleMapper for Step<'_> {
    fn map_float<const D: usize>(&mut self, parameter: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let (id, value, mapper) = parameter.consume();
        let value = match value.grad(self.gradients) {
            Some(gradient) => {
                let shape = gradient.dims();
                let by = self.by(gradient.flatten(0, D - 1)).reshape(shape);
                Tensor::from_inner(value.inner() - by).require_grad()
            }
            None => value,
        };
        Param::from_mapped_value(id, value, mapper)
    }
}

#[cfg(test)]
mod tests {
    use burn::{
        nn::Linear,
        tensor::{Device, TensorData},
    };

    use super::*;

    #[test]
    fn two_steps_follow_the_paper() {
        let device = Device::flex().autodiff();
        let data = |numbers: Vec<f32>| TensorData::new(numbers, [2, 1]);
        let mut model = Linear {
            weight: Param::from_data(data(vec![1.0, -2.0]), &device),
            bias: None,
        };
        let mut adam = Adam::default();
        // The loss is x·w, and its gradient x.
        let (mut expected, mut first, mut second) = ([1.0, -2.0], [0.0; 2], [0.0; 2]);
        for (step, x) in [[0.5, -1.0], [2.0, 0.25]].into_iter().enumerate() {
            let inputs = TensorData::new(x.map(|x| x as f32).to_vec(), [1, 2]);
            let loss = model.forward(Tensor::<2>::from_data(inputs, &device)).sum();
            model = adam.step(0.1, model, &loss.backward());
            for i in 0..2 {
                first[i] = 0.9 * first[i] + 0.1 * x[i];
                second[i] = 0.999 * second[i] + 0.001 * x[i] * x[i];
                let time = step as i32 + 1;
                let first = first[i] / (1.0 - 0.9f64.powi(time));
                let second: f64 = second[i] / (1.0 - 0.999f64.powi(time));
                expected[i] -= 0.1 * first / (second.sqrt() + 1e-5);
            }
        }
        let weights = model.weight.val().into_data();
        for (weight, expected) in weights.iter::<f64>().zip(expected) {
            assert!((weight - expected).abs() < 1e-6, "{weights:?}");
        }
    }
}
