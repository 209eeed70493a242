enable f16;
// The float that a probe computes with.
alias real = f16;

