from .spark_dsg import write_spark_dsg as write_spark_dsg
from .spark_dsg_reader import read_spark_dsg as read_spark_dsg
