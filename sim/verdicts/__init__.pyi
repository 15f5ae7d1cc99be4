from .comparison import Comparison as Comparison
from .comparison import compare as compare
from .comparison import compare_results as compare_results
from .rate import RateVerdict as RateVerdict
from .rate import assert_rate as assert_rate
from .stored_results import load_results as load_results
from .stored_results import save_results as save_results
