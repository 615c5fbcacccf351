// What every page without a script of its own does: it says that it is ready.
document.documentElement.dataset.ready = "yes";
